// Several result files as if they were one, for what tells of them side by side.
#pragma once
#include <string>
#include <vector>

#include "store/rows.h"

namespace crowdbench {

struct NamedContents {
  std::string name;  // the file's, unlike the others'
  StoreContents contents;
};

// The rows of all files in their order, with new ids (and references to ids) so that none meets another's, and by run
// the name of the file that it is from (`sources`). One file is given back as it is, without sources.
StoreContents joined(std::vector<NamedContents> files);

}  // namespace crowdbench
