MODULE triggers
CONST robtarget p1:=[[600,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget p2:=[[650,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
TriggIO gunon,10\DOp:=do1,1;
MoveJDO p1,v100,fine,tool0,do1,1;
TriggL p2,v100,gunon,z10,tool0;
TriggL p1,v100,gunon\T2:=gunoff,z10,tool0\WObj:=wobj0;
SearchL \Stop,di1,p3,p1,v100,tool0;
ArcLStart p1,v100,sm1,wd1,fine,tool0;
ArcL p2,v100,sm1,wd1,fine,tool0;
MoveLSync p2,v100,z10,tool0,"my_proc";
ENDPROC
ENDMODULE
