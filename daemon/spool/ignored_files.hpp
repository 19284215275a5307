// Files in incoming/ that will not be printed as they are: a folder that is not a plate, a file that is not
// a model. Each is reported once, after it has been unchanged for some seconds: an upload may still get its
// final name. Event loop's thread only.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/spool/why_ignored.hpp"
#include "daemon/system/event_loop.hpp"

namespace contourd {

// Receives the reports about ignored files.
class IgnoredFilesObserver {
 public:
  virtual ~IgnoredFilesObserver() = default;

  // Called when incoming/`file` will not be printed as it is.
  virtual void ignored(const std::string& file, WhyIgnored why) = 0;
  // Called with the number of further ignored files, which are not reported by name.
  virtual void more_ignored(std::size_t files) = 0;
};

class IgnoredFiles {
 public:
  // A file is reported after it has been unchanged for `settled`. Loop and observer must outlive the object.
  IgnoredFiles(EventLoop& loop, IgnoredFilesObserver& observer, Duration settled = std::chrono::seconds{5})
      : loop_(loop), observer_(observer), settled_after_(settled) {}

  // Notes that the file exists, is new or has changed, and is ignored.
  void saw(const std::string& file, WhyIgnored why);
  // Notes that the file is gone or will be printed.
  void forget(const std::string& file);
  void forget_all_but(const std::set<std::string>& files);

  // The files that were reported by name or by number, and still exist.
  [[nodiscard]] const std::map<std::string, WhyIgnored>& files() const { return settled_; }

 private:
  struct Unsettled {
    WhyIgnored why;
    TimePoint changed;
  };
  void wait();
  void forget_unsettled(const std::string& file);
  void settle_some();
  void settle(const std::string& file, WhyIgnored why);

  EventLoop& loop_;
  IgnoredFilesObserver& observer_;
  Duration settled_after_;
  std::map<std::string, WhyIgnored> settled_;
  std::map<std::string, Unsettled> unsettled_;
  std::set<std::pair<TimePoint, std::string>> by_change_;  // the keys of unsettled_
  std::size_t named_ = 0, unnamed_ = 0;                    // reported since unsettled_ was last empty
  EventLoop::SourcePtr timer_;
};

}  // namespace contourd
