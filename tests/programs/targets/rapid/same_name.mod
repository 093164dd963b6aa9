MODULE same_name
PROC a()
CONST robtarget p1:=[[600,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
MoveL p1,v100,fine,tool0;
ENDPROC
PROC b()
CONST robtarget p1:=[[600,0,700],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
MoveL p1,v100,fine,tool0;
MoveL [[600,0,700],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
ENDPROC
ENDMODULE
