// Part of every sanitizer build: libraries stay loaded. OpenGL drivers and X11 are unloaded at the end, and
// LeakSanitizer can neither follow what their memory points to nor name them in a suppression once they are gone.
extern "C" int dlclose(void* /*handle*/) noexcept { return 0; }
