// The topics of `contourctl help`: pages, their sections, and the words of the glossary. Thread-safe
// (immutable).
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace contourd::ctl {

// A page in Markdown, with one heading of the first level, at its beginning.
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
  // The pages' names and texts must outlive this object.
  explicit HelpTopics(std::span<const HelpPage> pages);

  // The pages in their order, each followed by its sections.
  [[nodiscard]] const std::vector<HelpTopic>& all() const { return topics_; }
  // Finds the topics that match, best first: topics with this name, then topics with these words in their
  // names, then topics that mention the words. Case is ignored, a hyphen equals a space, and a page's name
  // may precede a section's.
  [[nodiscard]] std::vector<const HelpTopic*> find(std::string_view words) const;
  // Returns up to three similar names, of topics or of `others`, the most similar first.
  [[nodiscard]] std::vector<std::string> nearest(std::string_view words,
                                                 std::span<const std::string> others) const;

 private:
  void add_sections(const HelpPage& page);
  void add_words(const HelpPage& page);

  std::vector<HelpTopic> topics_;
  std::vector<HelpTopic> words_;  // entries of the glossary
};

// Returns the words after `contourctl help` that show this topic.
[[nodiscard]] std::string typed(const HelpTopic& topic);

}  // namespace contourd::ctl
