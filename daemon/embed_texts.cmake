# Writes OUTPUT, a C++ source file with each of FILES as the string_view of its name in NAMES, as HEADER (an include
# path) declares them.
# Byte by byte: a string literal has a length limit and escapes of its own.
set(text "#include \"${HEADER}\"\n\nnamespace contourd {\n")
foreach(name file IN ZIP_LISTS NAMES FILES)
  file(READ ${file} bytes HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${bytes}")
  string(APPEND text
    "static constexpr char ${name}_bytes[] = {${bytes}};\n"
    "constinit const std::string_view ${name}{${name}_bytes, sizeof ${name}_bytes};\n")
endforeach()
string(APPEND text "}  // namespace contourd\n")
file(WRITE ${OUTPUT} "${text}")
