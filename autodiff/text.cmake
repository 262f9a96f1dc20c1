# Headers as C arrays of lines, without includes of the project's own.
#   cmake -DFOLDER=autodiff -DOUTPUT=text.c -P text.cmake
set(text "#include \"autodiff/c_code.h\"\n")
foreach(name exp exp_single lanes sine sine_single stumpff tanh tanh_single)
    file(READ ${FOLDER}/${name}.h lines)
    string(REGEX REPLACE "#include \"[^\n]*\n" "" lines "${lines}")
    string(REPLACE "\\" "\\\\" lines "${lines}")
    string(REPLACE "\"" "\\\"" lines "${lines}")
    string(REPLACE "\n" "\\n\",\n    \"" lines "${lines}")
    string(APPEND text "\nconst char *const ad_text_${name}[] = {\n    \"${lines}\", NULL};\n")
endforeach()
file(WRITE ${OUTPUT} "${text}")
