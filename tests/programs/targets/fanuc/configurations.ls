/PROG  CONFIGURATIONS
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "";
PROG_SIZE	= 1822;
CREATE		= DATE 24-12-22  TIME 18:35:46;
LINE_COUNT	= 3;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:J P[1] 100% FINE    ;
   2:J P[2] 100% FINE    ;
   3:J P[3] 100% FINE    ;
   4:J P[4] 100% FINE    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 0,		CONFIG : 'F U T, 0, 0, -1',
	X =  1234.567  mm,	Y =   -12.300  mm,	Z =      .000  mm,
	W =   179.999 deg,	P =     -.384 deg,	R =     -.001 deg
};
P[2]{
   GP1:
	UF : 0, UT : 0,		CONFIG : 'N D B, 1, 0, 0',
	X =  1250.000  mm,	Y =    12.300  mm,	Z =   500.000  mm,
	W =  -179.999 deg,	P =     0.000 deg,	R =    90.000 deg
};
P[3]{
   GP1:
	UF : 0, UT : 0,		CONFIG : 'N R D B, , , ',
	X =  1234.567  mm,	Y =   -12.300  mm,	Z =      .000  mm,
	W =   179.999 deg,	P =     -.384 deg,	R =     -.001 deg
};
P[4]{
   GP1:
	UF : 0, UT : 0,		CONFIG : '',
	X =  1250.000  mm,	Y =    12.300  mm,	Z =   500.000  mm,
	W =  -179.999 deg,	P =     0.000 deg,	R =    90.000 deg
};
/END
