// Where a job's files lie. A value.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/system/regular_file.hpp"

namespace contourd {

struct JobFiles {
  std::string name;                             // unique among all jobs in the spool; fit for a file's name
  std::filesystem::path model;                  // an STL file, or a plate's folder
  std::optional<std::filesystem::path> ticket;  // beside an STL file
  bool plate = false;
  Links links = Links::Follow;  // of these files
  std::string original{};       // in incoming/: what these are a copy of; empty when they were moved
};

// Of a print's report; a path is empty where there is none.
struct ReportFiles {
  std::filesystem::path json, html;
};

}  // namespace contourd
