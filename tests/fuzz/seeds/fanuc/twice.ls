/PROG  E
/MN
   1:L P[1] 250mm/sec FINE    ;
   2:L P[2] 250mm/sec FINE    ;
   3:L P[3] 250mm/sec FINE    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 0,	CONFIG : 'N U T, 0, 0, 0',
	X =  1200  mm,	Y =  0  mm,	Z =  0  mm,
	W =  180 deg,	P =  0 deg,	R =  0 deg,
	E1= 5  mm
};
P[2]{
   GP1:
	UF : 0, UT : 0,	CONFIG : 'N U T, 0, 0, 0',
  mm
};
P[2]{
   GP1:
	UF : 0	X =  1300  mm,	Y =  0  mm,	Z =  0  mm,
	W =  180 deg,	P =  0 deg,	R =  0 deg,
	E1= 5  mm
};
P[3]{
   GP1:
	UF : 0, UT : 0,	CONFIG : 'N U T, 0, 0, 0',
	X/ATTR 0  mm,E1 ==  180 deg,	P =  0 deg,	R =  0 deg,
	E1= 6  mm
};
/END
