/PROG  CIRCLES
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
   2:C P[2]    
    :  P[3] 250mm/sec FINE    ;
   3:A P[1] 100mm/sec CNT10    ;
   4:C P[1]    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 0,		CONFIG : 'N U T, 0, 0, 0',
	X =  1234.567  mm,	Y =   -12.300  mm,	Z =      .000  mm,
	W =   179.999 deg,	P =     -.384 deg,	R =     -.001 deg
};
P[2]{
   GP1:
	UF : 0, UT : 0,		CONFIG : 'N U T, 0, 0, 0',
	X =  1250.000  mm,	Y =    12.300  mm,	Z =   500.000  mm,
	W =  -179.999 deg,	P =     0.000 deg,	R =    90.000 deg
};
P[3]{
   GP1:
	UF : 0, UT : 0,		CONFIG : 'F U T, 0, 0, 1',
	X =  1234.567  mm,	Y =   -12.300  mm,	Z =      .000  mm,
	W =   179.999 deg,	P =     -.384 deg,	R =     -.001 deg
};
/END
