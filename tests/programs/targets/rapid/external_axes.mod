MODULE external_axes
CONST robtarget p1:=[[600,0,800],[1,0,0,0],[0,0,0,0],[1250.5,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget p2:=[[600,0,800],[1,0,0,0],[0,0,0,0],[1300,-45,9E9,9E9,9E9,9E9]];
PROC main()
MoveL p1,v100,fine,tool0;
MoveL p2,v100,fine,tool0;
ENDPROC
ENDMODULE