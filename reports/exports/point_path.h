// A point's name where other tools take one text for it, its factors readable in it.
#pragma once
#include <string>

#include "store/rows.h"

namespace crowdbench::reports {

// "crowd/representation:flat/character:mannequin/agents:250/occupancy:0.15/640x480".
std::string point_path(const PointKey& key);

}  // namespace crowdbench::reports
