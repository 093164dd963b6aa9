MODULE simple
  ! a comment with MoveL p99,v100,fine,tool0;
  CONST robtarget p10:=[[600,100.5,800.25],[0.707107,0,0.707107,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget p20:=[[650,100.5,800.25],[0.707107,0,0.707107,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveJ p10,v1000,z50,tool0;
    MoveL p20,v100,fine,tool0\WObj:=wobj0;
    MoveL p10,v100,fine,tool0;
  ENDPROC
ENDMODULE
