// What `contourctl help` knows: pages, their sections, and the words of the glossary. Thread-safe (no state
// that changes).
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace contourd::ctl {

// In Markdown, with one heading of the first level, at its beginning.
struct HelpPage {
  std::string_view name;
  std::string_view text;
};

struct HelpTopic {
  std::string_view page;
  std::string title;
  std::string text;  // Markdown
  bool whole_page = false;
};

class HelpTopics {
 public:
  // The pages' texts must outlive it.
  explicit HelpTopics(std::span<const HelpPage> pages);

  // The pages, in their order, each with its sections behind it.
  [[nodiscard]] const std::vector<HelpTopic>& all() const { return topics_; }
  // What is meant first: named so, named by these words among others, or speaking of them. Upper and lower
  // case, and hyphens and spaces, are alike; a page's name may stand before a section's.
  [[nodiscard]] std::vector<const HelpTopic*> find(std::string_view words) const;
  // Names that are nearly so, of these and of `others`; the nearest first.
  [[nodiscard]] std::vector<std::string> nearest(std::string_view words,
                                                 std::span<const std::string> others) const;

 private:
  void add_sections(const HelpPage& page);
  void add_words(const HelpPage& page);

  std::vector<HelpTopic> topics_;
  std::vector<HelpTopic> words_;  // the glossary's
};

// As the user types it behind `contourctl help`.
[[nodiscard]] std::string typed(const HelpTopic& topic);

}  // namespace contourd::ctl
