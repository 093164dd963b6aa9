/PROG  LOGIC
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "";
PROG_SIZE	= 1822;
CREATE		= DATE 24-12-22  TIME 18:35:46;
LINE_COUNT	= 3;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  LBL[1] ;
   2:  CALL OTHER(1,"P[1]") ;
   3:  IF DI[1]=ON,JMP LBL[1] ;
   4:  WAIT (DI[25])    ;
   5:  //L P[9] 250mm/sec FINE    ;
   6:  PAYLOAD[2] ;
   7:L P[1] 250mm/sec FINE
    :  TB   .10sec,CALL OTHER    ;
   8:  FOR R[1]=1 TO 3 ;
   9:J P[2] R[5]% FINE    ;
  10:  ENDFOR ;
  11:  END ;
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
