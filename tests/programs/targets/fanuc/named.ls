/PROG  NAMED
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "";
PROG_SIZE	= 1822;
CREATE		= DATE 24-12-22  TIME 18:35:46;
LINE_COUNT	= 3;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:J P[1:home] 100% FINE    ;
   2:L P[2:"part; one"] 250mm/sec FINE    ;
/POS
P[1:"home"]{
   GP1:
	UF : 0, UT : 1,	
	J1=    10.000 deg,	J2=   -20.500 deg,	J3=   -30.000 deg,
	J4=      .000 deg,	J5=   -60.000 deg,	J6=      .001 deg
};
P[2:"part; one"]{
   GP1:
	UF : 1, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =  1250.000  mm,	Y =    12.300  mm,	Z =   500.000  mm,
	W =  -179.999 deg,	P =     0.000 deg,	R =    90.000 deg
};
/END
