MODULE joints
  LOCAL CONST jointtarget jHome:=[[0,0,0,0,30,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  VAR jointtarget jb := [ [ 10.5 , -20 , 1.5E1 , 0.000001 , 45 , -180 ] , [ 100, 9E9,9E9,9E9,9E9,9E9] ] ;
  PROC main()
    MoveAbsJ jHome\NoEOffs,v1000,fine,tool0;
    MoveAbsJ jb,v1000\T:=5,z10\Inpos:=inpos50,tool0\WObj:=wobj0;
    MoveAbsJ [[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]]\NoEOffs,v1000,fine,tool0;
    MoveAbsJ [[1,2,3,4,5,9E9],[9E9,9E9,9E9,9E9,9E9,9E9]],v1000,fine,tool0;
    MoveAbsJ CalcJointT(p1,tool0),v1000,fine,tool0;
  ENDPROC
ENDMODULE
