// Whether this is a sanitizer build: CROWDBENCH_HAS_SANITIZER is 1 or 0, for the preprocessor too.
#pragma once

#if defined(__SANITIZE_ADDRESS__)
#define CROWDBENCH_HAS_SANITIZER 1
#elif defined(__has_feature)
#define CROWDBENCH_HAS_SANITIZER __has_feature(address_sanitizer)
#else
#define CROWDBENCH_HAS_SANITIZER 0
#endif
