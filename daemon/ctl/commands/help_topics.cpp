#include "daemon/ctl/commands/help_topics.hpp"

#include <algorithm>
#include <cctype>
#include <numeric>

#include "daemon/ctl/terminal/markdown_text.hpp"

namespace contourd::ctl {
namespace {

constexpr std::string_view kGlossary = "glossary";

bool is_word_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0;
}

// Returns the text in lower case, with single spaces in place of other characters.
std::string normalized(std::string_view text) {
  std::string words;
  for (const char c : text) {
    if (is_word_character(c))
      words += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!words.empty() && words.back() != ' ' && c != '\'')
      words += ' ';
  }
  while (words.ends_with(' '))
    words.pop_back();
  return words;
}

// Counts the places where `words` begin at the start of a word. Both texts are normalized.
std::size_t times_in(std::string_view text, std::string_view words) {
  std::size_t times = 0;
  for (std::size_t at = text.find(words); at != std::string_view::npos; at = text.find(words, at + 1))
    times += at == 0 || text[at - 1] == ' ' ? 1U : 0U;
  return times;
}

std::vector<std::string_view> cells_of(std::string_view row) {
  std::vector<std::string_view> cells;
  row.remove_prefix(1);
  while (!row.empty()) {
    const std::size_t end = std::min(row.find(" |"), row.size());
    cells.push_back(row.substr(0, end));
    row.remove_prefix(std::min(end + 2, row.size()));
  }
  return cells;
}

std::string_view first_line(std::string_view text) {
  return text.substr(0, text.find('\n'));
}

std::string title_of(std::string_view section) {
  std::string_view line = first_line(section);
  line.remove_prefix(std::min(line.find_first_not_of("# "), line.size()));
  return plain_words(line);
}

// Returns the Levenshtein distance.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t before = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t same = before + (a[i] == b[j] ? 0 : 1);
      before = row[j + 1];
      row[j + 1] = std::min({same, before + 1, row[j] + 1});
    }
  }
  return row.back();
}

}  // namespace

HelpTopics::HelpTopics(std::span<const HelpPage> pages) {
  for (const HelpPage& page : pages) {
    topics_.push_back({page.name, title_of(page.text), std::string(page.text), true});
    add_sections(page);
    if (page.name == kGlossary) add_words(page);
  }
}

void HelpTopics::add_sections(const HelpPage& page) {
  constexpr std::string_view kHeading = "\n## ";
  for (std::size_t at = page.text.find(kHeading); at != std::string_view::npos;) {
    const std::size_t next = page.text.find(kHeading, at + 1);
    const std::string_view section = page.text.substr(at + 1, next - at - 1);
    topics_.push_back({page.name, title_of(section), std::string(section)});
    at = next;
  }
}

void HelpTopics::add_words(const HelpPage& page) {
  for (std::size_t at = page.text.find("\n| "); at != std::string_view::npos;
       at = page.text.find("\n| ", at + 1)) {
    const std::vector<std::string_view> cells = cells_of(first_line(page.text.substr(at + 1)));
    if (cells.size() < 2) continue;
    std::string word = plain_words(cells[0]);
    if (word == "word") continue;  // a table's head
    std::string text = "## " + word + "\n\n" + std::string(cells[1]) + "\n";
    words_.push_back({page.name, std::move(word), std::move(text)});
  }
}

std::vector<const HelpTopic*> HelpTopics::find(std::string_view words) const {
  struct Found {
    const HelpTopic* topic;
    std::size_t rank, times;
  };
  const std::string wanted = normalized(words);
  std::vector<Found> found;
  const auto add_if_matching = [&](const HelpTopic& topic, std::size_t handicap) {
    const std::string page = normalized(topic.page), title = normalized(topic.title);
    const std::size_t times = topic.whole_page ? 0 : times_in(normalized(topic.text), wanted);
    const bool is_called =
        topic.whole_page ? wanted == page : wanted == title || wanted == page + " " + title;
    if (is_called || (topic.whole_page && wanted == title))
      found.push_back({&topic, is_called ? handicap : 1, times});
    else if (times_in(title, wanted) > 0)
      found.push_back({&topic, 2 + handicap, times});
    else if (times > 0 && handicap == 0)
      found.push_back({&topic, 4, times});
  };
  if (wanted.empty()) return {};
  for (const HelpTopic& topic : topics_)
    add_if_matching(topic, 0);
  for (const HelpTopic& word : words_)
    add_if_matching(word, 1);
  std::ranges::stable_sort(found, [](const Found& a, const Found& b) {
    return a.rank != b.rank ? a.rank < b.rank : a.times > b.times;
  });
  std::vector<const HelpTopic*> topics;
  for (const Found& each : found)
    topics.push_back(each.topic);
  return topics;
}

std::vector<std::string> HelpTopics::nearest(std::string_view words,
                                             std::span<const std::string> others) const {
  constexpr std::size_t kMost = 3;
  const std::string wanted = normalized(words);
  std::vector<std::string> names(others.begin(), others.end());
  for (const std::vector<HelpTopic>* topics : {&topics_, &words_})
    for (const HelpTopic& topic : *topics)
      names.push_back(normalized(topic.whole_page ? std::string(topic.page) : topic.title));
  const auto is_far = [&](const std::string& name) {
    return distance(normalized(name), wanted) > std::max<std::size_t>(2, wanted.size() / 3);
  };
  std::erase_if(names, is_far);
  std::ranges::stable_sort(names, {},
                           [&](const std::string& name) { return distance(normalized(name), wanted); });
  names.erase(std::unique(names.begin(), names.end()), names.end());
  names.resize(std::min(names.size(), kMost));
  return names;
}

std::string typed(const HelpTopic& topic) {
  return topic.whole_page ? std::string(topic.page) : std::string(topic.page) + ' ' + normalized(topic.title);
}

}  // namespace contourd::ctl
