MODULE tools
  PERS tooldata tGun:=[TRUE,[[31.792631019,0,229.638935148],[0.945518576,0,0.325568154,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  TASK PERS wobjdata wTable:=[FALSE,TRUE,"",[[800,0,300],[0.707106781,0,0,0.707106781]],[[10,20,30],[1,0,0,0]]];
  PERS wobjdata wMoved:=[FALSE,FALSE,"STN1",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  PERS tooldata tFixed:=[FALSE,[[0,0,0],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  PROC main()
    MoveJ [[10,20,300],[0,0.7071068,0.7071068,0],[-1,0,-2,1],[9E9,9E9,9E9,9E9,9E9,9E9]],v1000,z50,tGun\WObj:=wTable;
    MoveL [[10,20,100],[0,0.7071068,0.7071068,0],[-1,0,-2,1],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tGun \WObj:=wTable \TLoad:=load0;
    MoveL [[10,20,100],[0,0.7071068,0.7071068,0],[-1,0,-2,1],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tGun\WObj:=wMoved;
    MoveL [[10,20,100],[0,0.7071068,0.7071068,0],[-1,0,-2,1],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tFixed\WObj:=wobj0;
    MoveL [[10,20,100],[0,0.7071068,0.7071068,0],[-1,0,-2,1],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tElsewhere\WObj:=wElsewhere;
  ENDPROC
ENDMODULE
