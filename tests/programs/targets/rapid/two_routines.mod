MODULE two_routines
LOCAL CONST robtarget p1:=[[600,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC a()
MoveL p1,v100,fine,tool0;
ENDPROC
PROC b(num n, PERS robtarget q)
CONST robtarget p2:=[[600,0,700],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
MoveL p2,v100,fine,tool0;
MoveL q,v100,fine,tool0;
ENDPROC
FUNC robtarget c()
RETURN p1;
ENDFUNC
ENDMODULE
