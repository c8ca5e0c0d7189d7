// Part of every sanitizer build: what LeakSanitizer needs to work beside OpenGL drivers.

// Libraries stay loaded. Drivers and X11 are unloaded at the end, and the leak check can neither follow what their
// memory points to nor name them in a suppression once they are gone.
extern "C" int dlclose(void* /*handle*/) noexcept { return 0; }

// The runtime guesses how glibc placed a library's thread-local block: an address 16 bytes into a page is taken for
// the layout of glibc before 2.25, and the two words in front of it for the block's size and start. Allocated by
// the sanitizer itself, one block in 256 lies so, and the leak check then reads from wherever those words point and
// dies ("Tracer caught signal 11"). Nothing here needs these blocks scanned, so the guess is not made.
extern "C" const char* __asan_default_options() { return "intercept_tls_get_addr=0"; }
