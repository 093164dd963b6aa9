/PROG  ASSIGNED
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "";
PROG_SIZE	= 1822;
CREATE		= DATE 24-12-22  TIME 18:35:46;
LINE_COUNT	= 3;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  P[1]=LPOS    ;
   2:L P[1] 250mm/sec FINE    ;
   3:L P[2] 250mm/sec FINE    ;
/POS
P[1]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =  1234.567  mm,	Y =   -12.300  mm,	Z =      .000  mm,
	W =   179.999 deg,	P =     -.384 deg,	R =     -.001 deg
};
P[2]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =  1250.000  mm,	Y =    12.300  mm,	Z =   500.000  mm,
	W =  -179.999 deg,	P =     0.000 deg,	R =    90.000 deg
};
/END
