# Writes OUTPUT, a C++ source file with each FOLDER/NAME.schema.json of SCHEMAS as the string_view
# NAME_schema_text.
# Byte by byte: a string literal has a length limit and escapes of its own.
set(text "#include \"daemon/config/schema_text.hpp\"\n\nnamespace contourd {\n")
foreach(name IN LISTS SCHEMAS)
  file(READ ${FOLDER}/${name}.schema.json bytes HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${bytes}")
  string(APPEND text
    "static constexpr char ${name}_bytes[] = {${bytes}};\n"
    "constinit const std::string_view ${name}_schema_text{${name}_bytes, sizeof ${name}_bytes};\n")
endforeach()
string(APPEND text "}  // namespace contourd\n")
file(WRITE ${OUTPUT} "${text}")
