// A folder for one test: nobody else's, whatever runs beside it, and gone afterwards.
#pragma once

#include "core/temporary_folder.h"

namespace crowdbench::support {

class ScratchFolder : public TemporaryFolder {
 public:
  ScratchFolder() : TemporaryFolder("test") {}
};

}  // namespace crowdbench::support
