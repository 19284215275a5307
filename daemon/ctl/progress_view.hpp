// How far a print is, for who follows it: a line that is drawn over itself on a terminal; elsewhere a line
// for every tenth of the print. Warnings have lines of their own, once.
#pragma once

#include <set>
#include <string>

#include "daemon/ctl/daemon_connection.hpp"

namespace contourd::ctl {

class ProgressView {
 public:
  using Json = DaemonConnection::Json;

  ProgressView();

  void show(const Json& status);
  // The same of one job, which may be waiting.
  void show_job(const Json& status, const std::string& name, bool is_under_way);
  // Nothing is drawn over any more.
  void end();

 private:
  void show_warnings(const Json& job);
  // Of a print that has a layer. `columns`: of the terminal.
  [[nodiscard]] static std::string bar_of(const Json& job, const std::string& state, std::size_t columns);
  // `step` changes when a line is due that nothing draws over.
  void draw(const std::string& text, const std::string& step);

  bool terminal_;
  bool drawn_ = false;
  std::string last_step_;
  std::set<std::string> warned_;  // the job's name and the warning
};

}  // namespace contourd::ctl
