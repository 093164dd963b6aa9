/PROG COMPACT
/MN
1:J P[1] 100% FINE;
2:L P[1] 100mm/sec FINE;
/POS
P[1]{GP1:UF:1,UT:1,CONFIG:'N U T,0,0,0',X=1mm,Y=2mm,Z=3mm,W=4deg,P=5deg,R=6deg};
/END