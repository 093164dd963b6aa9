/PROG  decimals
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "";
PROG_SIZE	= 1822;
CREATE		= DATE 24-12-22  TIME 18:35:46;
LINE_COUNT	= 3;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:L P[1] 250mm/sec FINE    ;
/POS
P[1]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 1234.56789  mm,	Y =     1.5E2  mm,	Z =       +.5  mm,
	W =       12. deg,	P =    -0.000 deg,	R =      1e-2 deg
};
/END
