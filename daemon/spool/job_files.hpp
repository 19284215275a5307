// The paths of a job's files. A value.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/system/regular_file.hpp"

namespace contourd {

struct JobFiles {
  std::string name;                             // unique among all jobs in the spool; usable in file names
  std::filesystem::path model;                  // a model, or a plate's folder
  std::optional<std::filesystem::path> ticket;  // the ticket beside a model
  bool plate = false;
  Links links = Links::Follow;  // treatment of symbolic links in place of the files
  std::string original{};       // the name in incoming/ of the original if these files are a copy, else empty
};

// The files of a print's report; a path is empty if the file does not exist.
struct ReportFiles {
  std::filesystem::path json, html;
};

}  // namespace contourd
