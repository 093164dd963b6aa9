MODULE offsets
CONST robtarget p1:=[[600,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR robtarget p2:=[[600,10,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PERS robtarget p3:=[[600,20,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR robtarget p4;
PROC main()
MoveL p1,v100,fine,tool0;
MoveL Offs(p1,0,0,50),v100,fine,tool0;
MoveL RelTool(p1,0,0,50\Rz:=90),v100,fine,tool0;
p2:=CRobT();
MoveL p2,v100,fine,tool0;
p3.trans.z:=p3.trans.z+1;
MoveL p3,v100,fine,tool0;
MoveL p4,v100,fine,tool0;
MoveL pUnknown,v100,fine,tool0;
MoveL *,v100,fine,tool0;
ENDPROC
ENDMODULE
