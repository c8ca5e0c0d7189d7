/* jsPsych's files, byte for byte; studies/page/page.cpp reads them. */
#define EMBED(name, path)                 \
  .global crowdbench_##name##_begin;      \
  .global crowdbench_##name##_end;        \
  crowdbench_##name##_begin: .incbin path; \
  crowdbench_##name##_end: .byte 0;

  .section .rodata
EMBED(jspsych_js, JSPSYCH_JS)
EMBED(plugin_html_button_response_js, PLUGIN_HTML_BUTTON_RESPONSE_JS)
EMBED(plugin_survey_html_form_js, PLUGIN_SURVEY_HTML_FORM_JS)
  .section .note.GNU-stack, "", @progbits
