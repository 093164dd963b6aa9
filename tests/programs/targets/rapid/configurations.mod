MODULE configurations
PROC main()
MoveJ [[600,0,800],[1,0,0,0],[-1,2,-3,5],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
MoveJ [[600,0,800],[1,0,0,0],[0,0,0,1],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
MoveJ [[600,0,800],[1,0,0,0],[9E9,9E9,9E9,9E9],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
MoveJ [[600,0,800],[1,0,0,0],[0.5,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
ConfL\Off;
MoveL [[600,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
ENDPROC
ENDMODULE
