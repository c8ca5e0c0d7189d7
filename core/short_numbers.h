// Numbers written as short as tells them apart: for tables whose rows are known by numbers of many digits.
#pragma once
#include <map>
#include <set>
#include <string>

namespace crowdbench {

// By each text what stands for it: texts that are not numbers in plain or scientific decimals are themselves, and so
// are all where none is longer than six characters; else numbers are rounded to as few significant digits, three at
// least, as leave all of them different.
std::map<std::string, std::string> short_numbers(const std::set<std::string>& texts);

}  // namespace crowdbench
