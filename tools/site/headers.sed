# Marks the comments of a header for Doxygen: of the file, before a declaration, behind a member.
/^\/\* ----/b
1s,^/\* ,/** \\file\n * ,
s,^( *)/\* ,\1/** ,
s,([;\,{] *)/\* ,\1/**< ,
