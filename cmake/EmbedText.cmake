# Writes OUT, a C++ file that defines crowdbench::gl::kEmbeddedShaders: {path below ROOT, text} of each of FILES.
set(text "// Generated from the shader files.\n#include \"renderers/gl/embedded.h\"\n\nnamespace crowdbench::gl {\nconst std::vector<EmbeddedShader>& embedded_shaders() {\n  static const std::vector<EmbeddedShader> all = {\n")
foreach(file IN LISTS FILES)
  file(READ ${ROOT}/${file} content)
  # A raw string literal may hold 64 KiB; shaders stay well below.
  string(APPEND text "    {\"${file}\", R\"__glsl__(${content})__glsl__\"},\n")
endforeach()
string(APPEND text "  };\n  return all;\n}\n}  // namespace crowdbench::gl\n")
file(WRITE ${OUT} "${text}")
