/PROG  JOINTS
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
   2:J P[2] 50% CNT50 ACC80    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,	
	J1=    10.000 deg,	J2=   -20.500 deg,	J3=   -30.000 deg,
	J4=      .000 deg,	J5=   -60.000 deg,	J6=      .001 deg
};
P[2]{
   GP1:
	UF : 0, UT : 1,	
	J1=         0 deg,	J2=         0 deg,	J3=         0 deg,
	J4=         0 deg,	J5=       -90 deg,	J6=         0 deg,
	E1=   100.000  mm
};
/END
