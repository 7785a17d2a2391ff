# Writes OUTPUT, a C++ file that holds each of SOURCES as a raw string behind shader_source(name).
set(code "#include \"shader_sources.h\"\n\nnamespace halflight {\n\nstd::string_view shader_source(std::string_view name) {\n")
foreach(source IN LISTS SOURCES)
  file(READ ${FOLDER}/${source} text)
  string(APPEND code "  if (name == \"${source}\") return R\"GLSL(${text})GLSL\";\n")
endforeach()
string(APPEND code "  return {};\n}\n\n}  // namespace halflight\n")
file(WRITE ${OUTPUT} "${code}")
