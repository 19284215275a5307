// How far a print is, for who reads it as text: a line for every tenth of the print and for what changes
// otherwise. Warnings have lines of their own, once.
#pragma once

#include <set>
#include <string>

#include "daemon/client/daemon_connection.hpp"

namespace contourd::ctl {

class ProgressLines {
 public:
  using Json = DaemonConnection::Json;

  // `job`: the one that is waited for, which may not be under way; empty: whichever is.
  void show(const Json& status, const std::string& job, bool is_under_way);

 private:
  void show_job(const Json& status);
  void show_warnings(const Json& job);
  // `step` changes when a line is due.
  void print(const std::string& text, const std::string& step);

  std::string last_step_;
  std::set<std::string> warned_;  // the job's name and the warning
};

}  // namespace contourd::ctl
