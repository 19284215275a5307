#include "daemon/ctl/commands/help_topics.hpp"

#include "tests/catch.hpp"

using namespace contourd::ctl;

namespace {

constexpr std::array kPages{
    HelpPage{"after-print",
             "# After a print\n\nIt is over.\n\n## Cleaning the vat\n\nTilt it. Peel nothing.\n\n"
             "## Peel\n\nHow layers come off.\n"},
    HelpPage{"glossary",
             "# Glossary\n\n## The part\n\n| word | means | file |\n|---|---|---|\n"
             "| peel, peeling | what it takes | `a` |\n| island | hangs in the air | `b` |\n"}};

std::vector<std::string> found(const HelpTopics& topics, const char* words) {
  std::vector<std::string> names;
  for (const HelpTopic* topic : topics.find(words))
    names.push_back(typed(*topic));
  return names;
}

}  // namespace

using Names = std::vector<std::string>;

TEST_CASE("A topic is found by its page's name, its heading, or both") {
  const HelpTopics topics(kPages);
  CHECK(found(topics, "after-print").front() == "after-print");
  CHECK(found(topics, "After a print").front() == "after-print");
  CHECK(found(topics, "cleaning the VAT") == Names{"after-print cleaning the vat"});
  CHECK(found(topics, "after-print peel").front() == "after-print peel");
  CHECK(topics.find("peel").front()->text == "## Peel\n\nHow layers come off.\n");
}

TEST_CASE("Topics with the exact name come first, then topics with similar names, then mentions") {
  const HelpTopics topics(kPages);
  CHECK(found(topics, "peel") == Names{"after-print peel", "glossary peel peeling", "glossary the part",
                                       "after-print cleaning the vat"});
  CHECK(found(topics, "clean") == Names{"after-print cleaning the vat"});
  CHECK(found(topics, "tilt") == Names{"after-print cleaning the vat"});
  CHECK(found(topics, "eel").empty());  // no word begins with it
}

TEST_CASE("A word of the glossary is a topic") {
  const HelpTopics topics(kPages);
  CHECK(topics.find("island").front()->text == "## island\n\n hangs in the air\n");
  CHECK(found(topics, "word") == Names{"glossary the part"});  // the table's heading is not a topic
}

TEST_CASE("For an unknown topic, similar names are suggested") {
  const HelpTopics topics(kPages);
  CHECK(found(topics, "iland").empty());
  CHECK(topics.nearest("iland", {}) == Names{"island"});
  const std::vector<std::string> commands{"submit"};
  CHECK(topics.nearest("submti", commands) == Names{"submit"});
  CHECK(topics.nearest("something else", commands).empty());
  CHECK(topics.find("").empty());
  CHECK(topics.find("\x1b\n -").empty());
}
