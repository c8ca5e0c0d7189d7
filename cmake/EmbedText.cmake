# Writes OUT, a C++ file that defines NAMESPACE::FUNCTION() as HEADER declares it: a vector of TYPE {path below ROOT, text},
# one for each of FILES.
set(text "// Generated from text files.\n#include \"${HEADER}\"\n\nnamespace ${NAMESPACE} {\nconst std::vector<${TYPE}>& ${FUNCTION}() {\n  static const std::vector<${TYPE}> all = {\n")
foreach(file IN LISTS FILES)
  file(READ ${ROOT}/${file} content)
  # A raw string literal may hold 64 KiB; shaders and pages stay well below.
  string(APPEND text "    {\"${file}\", R\"__text__(${content})__text__\"},\n")
endforeach()
string(APPEND text "  };\n  return all;\n}\n}  // namespace ${NAMESPACE}\n")
file(WRITE ${OUT} "${text}")
