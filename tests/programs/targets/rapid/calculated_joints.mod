MODULE calculated_joints
PERS tooldata t1:=[TRUE,[[10,0,150],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
PERS wobjdata w1:=[FALSE,TRUE,"",[[600,0,300],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
CONST robtarget p1:=[[100,50,200],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
MoveJ p1,v100,fine,t1\WObj:=w1;
MoveAbsJ CalcJointT(RelTool(p1,0,50,0), T1 \WObj:=w1), v100,z5,t1\WObj:=w1;
MoveAbsJ CalcJointT(p1,t1\WObj:=w1), v100,z5,t1\WObj:=w1;
MoveAbsJ CalcJointT(p1,tool0\WObj:=w1), v100,z5,t1\WObj:=w1;
MoveAbsJ CalcJointT(p1,t1), v100,z5,t1\WObj:=w1;
MoveAbsJ CalcJointT(\UseCurWObjPos,p1,t1\WObj:=w1), v100,z5,t1\WObj:=w1;
ENDPROC
ENDMODULE
