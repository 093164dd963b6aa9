MODULE strings
CONST string s:="MoveL p1; ! no [[1,2,3]]";
CONST robtarget p1:=[[600,0,800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
TPWrite "p1 := [[1,2,3]]" ;
MoveL p1,v100,fine,tool0; ! MoveL p1,v100
TPWrite "grüße";
ENDPROC
ENDMODULE
