// The page that participants of a study see: jsPsych and what is shown with it, in a folder that needs nothing else.
//
// The page reads trials.json, texts and clips beside it (studies/plan/README.md says their form). It asks for nothing
// outside its folder, so that any static server shows it; under `crowdbench study serve` (studies/server) the answers
// go to the server as they are given.
#pragma once
#include <filesystem>

namespace crowdbench::studies {

// Writes index.html, the page's scripts and style sheet, vendor/ (jsPsych and two of its plugins, without references to
// source maps) and LICENCES.txt into `folder`, which exists; files of these names are replaced, others stay. Throws
// Error: no such folder, a full disk, a program that was built without the npm packages.
void write_page(const std::filesystem::path& folder);
// Throws Error where write_page would for want of the npm packages: before long work that ends with it.
void require_page();

}  // namespace crowdbench::studies
