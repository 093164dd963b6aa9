MODULE arrays
CONST robtarget pp{3}:=[[[600,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],
  [[610,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],
  [[620,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]];
PROC main()
MoveL pp{1},v100,fine,tool0;
MoveL pp{ 2 },v100,fine,tool0;
MoveL pp{i},v100,fine,tool0;
MoveL pp{4},v100,fine,tool0;
ENDPROC
ENDMODULE
