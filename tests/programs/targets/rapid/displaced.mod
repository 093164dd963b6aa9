MODULE displaced
CONST robtarget p1:=[[600,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
MoveL p1,v100,fine,tool0;
PDispOn \Rot,p1,tool0;
MoveL [[610,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
PDispOff;
MoveL [[620,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
ENDPROC
ENDMODULE
