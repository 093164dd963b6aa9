MODULE circles
CONST robtarget pa:=[[600,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget pb:=[[650,50,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget pc:=[[700,0,800],[1,0,0,0],[0,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
MoveJ pa,v1000,fine,tool0;
CirPathMode\ObjectFrame;
MoveC pb,pc,v100,z1,tool0\WObj:=wobj0;
CirPathMode\PathFrame;
MoveC Offs(pb,0,-100,0),pa,v100,fine,tool0;
ENDPROC
ENDMODULE
