%%%
  VERSION:1
  LANGUAGE:ENGLISH
%%%
MODULE multi_line(SYSMODULE, NOVIEW)
  CONST robtarget p1:=
    [ [600.123456,
       -0.5 , ! behind x
       800 ],
      [0.5,-0.5,0.5,-0.5],
      [ -1 , 1 , -4 , 0 ] , [9E9,9E9,9E9,9E9,9E9,9E9] ] ;
  PROC main()
    IF di1=1 THEN MoveL p1 , v100 , z5 , tool0 ; ENDIF
    IF (di1=1) MoveJ \Conc, p1, v100, z5, tool0;
    WHILE TRUE DO
      movel
        p1,
        v100\V:=200,
        fine,
        tool0;
    ENDWHILE
  ENDPROC
ENDMODULE
