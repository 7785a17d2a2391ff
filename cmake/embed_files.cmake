# Writes OUTPUT, a C++ file that holds each of SOURCES (in FOLDER) as a raw string behind FUNCTION(name), which HEADER
# declares.
set(code "#include \"${HEADER}\"\n\nnamespace halflight {\n\nstd::string_view ${FUNCTION}(std::string_view name) {\n")
foreach(source IN LISTS SOURCES)
  file(READ ${FOLDER}/${source} text)
  string(APPEND code "  if (name == \"${source}\") return R\"EMBED(${text})EMBED\";\n")
endforeach()
string(APPEND code "  return {};\n}\n\n}  // namespace halflight\n")
file(WRITE ${OUTPUT} "${code}")
