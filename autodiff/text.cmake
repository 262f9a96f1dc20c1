# Files as C arrays of lines, PREFIX_name without the ending, without includes of the project's own.
#   cmake -DFOLDER=autodiff -DFILES=lanes.h,tanh.h -DPREFIX=ad_text -DHEADER=autodiff/c_code.h
#         -DOUTPUT=text.c -P text.cmake
set(text "#include \"${HEADER}\"\n")
string(REPLACE "," ";" FILES "${FILES}")
foreach(file ${FILES})
    cmake_path(GET file STEM name)
    file(READ ${FOLDER}/${file} lines)
    string(REGEX REPLACE "#include \"[^\n]*/[^\n]*\n" "" lines "${lines}")
    string(REPLACE "\\" "\\\\" lines "${lines}")
    string(REPLACE "\"" "\\\"" lines "${lines}")
    string(REPLACE "\n" "\\n\",\n    \"" lines "${lines}")
    string(APPEND text "\nconst char *const ${PREFIX}_${name}[] = {\n    \"${lines}\", NULL};\n")
endforeach()
file(WRITE ${OUTPUT} "${text}")
