// What lies in incoming/ and will not be printed as it is: a folder that is no plate, a file that is no STL.
// Told of once each, when it has lain there unchanged for some seconds: what is being uploaded may get its
// right name yet. Event loop's thread only, but for why_ignored(), which any may call.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/system/event_loop.hpp"

namespace contourd {

enum class WhyIgnored {
  Folder,  // without plate.json
  Model,   // of another format
  Sliced,  // for another printer
  Archive,
  NotAFile,  // a link, a pipe, a device
  Other,
};

// What is odd about what lies in incoming/ and is neither a model by its name nor a folder. Nothing when it
// is gone, a ticket, which may wait for its model, hidden, or named as what is still being written.
[[nodiscard]] std::optional<WhyIgnored> why_ignored(const std::filesystem::path& path);

// The sentence for it: what is wanted instead.
[[nodiscard]] std::string_view sentence_for(WhyIgnored why);

class IgnoredFiles {
 public:
  // `tell` is called for each of the first of many, then once for the rest: with their number in place of a
  // name.
  struct Telling {
    std::function<void(const std::string& file, WhyIgnored why)> one;
    std::function<void(std::size_t files)> more;
  };
  // `settled` is how long it lies there unchanged.
  IgnoredFiles(EventLoop& loop, Telling tell, Duration settled = std::chrono::seconds{5});

  // It is there, new or changed.
  void saw(const std::string& file, WhyIgnored why);
  // It is gone, or is what will be printed.
  void forget(const std::string& file);
  void forget_all_but(const std::set<std::string>& files);

  // What was told of, or counted among the rest, and is still there.
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
  Telling tell_;
  Duration settled_after_;
  std::map<std::string, WhyIgnored> settled_;
  std::map<std::string, Unsettled> unsettled_;
  std::set<std::pair<TimePoint, std::string>> by_change_;  // the unsettled
  std::size_t told_ = 0, untold_ = 0;                      // since there were none unsettled
  EventLoop::SourcePtr timer_;
};

}  // namespace contourd
