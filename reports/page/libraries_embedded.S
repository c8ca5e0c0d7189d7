/* The chart library's files, byte for byte; reports/page/libraries.cpp reads them. */
#define EMBED(name, path)                 \
  .global crowdbench_##name##_begin;      \
  .global crowdbench_##name##_end;        \
  crowdbench_##name##_begin: .incbin path; \
  crowdbench_##name##_end: .byte 0;

  .section .rodata
EMBED(vega_js, VEGA_JS)
EMBED(vega_licence, VEGA_LICENCE)
EMBED(vega_lite_js, VEGA_LITE_JS)
EMBED(vega_lite_licence, VEGA_LITE_LICENCE)
EMBED(vega_embed_js, VEGA_EMBED_JS)
EMBED(vega_embed_licence, VEGA_EMBED_LICENCE)
  .section .note.GNU-stack, "", @progbits
