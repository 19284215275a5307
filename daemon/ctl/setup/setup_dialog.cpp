#include "daemon/ctl/setup/setup_dialog.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

namespace contourd::ctl {
namespace {

constexpr std::size_t kNoQuestion = static_cast<std::size_t>(-1);

}  // namespace

void SetupDialog::answer_all(Answers& answers, const SetupFacts& facts, const std::function<void()>& kept) {
  answer_from(kNoQuestion, answers, facts, kept);
}

void SetupDialog::answer_again(std::string_view key, Answers& answers, const SetupFacts& facts,
                               const std::function<void()>& kept) {
  const auto question = std::ranges::find(questions(), key, &Question::key);
  answer_from(static_cast<std::size_t>(question - questions().begin()), answers, facts, kept);
}

void SetupDialog::answer_from(std::size_t again, Answers& answers, const SetupFacts& facts,
                              const std::function<void()>& kept) {
  const auto all = questions();
  // Earlier answers are checked without this computer's devices: a device need not be plugged in now, and the
  // answers may be for another computer.
  const SetupFacts elsewhere{.devices = {}, .tables = facts.tables};
  std::vector<std::size_t> passed;
  for (std::size_t i = 0; i < all.size();) {
    const Question& question = all[i];
    const auto answer = answers.find(std::string(question.key));
    const bool asked = question.is_asked(answers, facts);
    if (asked && i != again && answer != answers.end()) {
      const TakenAnswer taken = question.take(answer->second, answers, elsewhere);
      if (taken.complaint.empty())
        answer->second = taken.answer;
      else
        again = i;
      if (again == i) say(fmt::format("{} = {}: {}", question.key, answer->second, taken.complaint));
    }
    if (!asked || (i != again && answer != answers.end())) {
      if (asked) passed.push_back(i);
      ++i;
      continue;
    }
    if (answer_one(question, answers, facts)) {
      again = kNoQuestion;
      passed.push_back(i++);
      kept();
    } else if (passed.empty()) {
      say("This is the first question.");
    } else {
      again = i = passed.back();
      passed.pop_back();
    }
  }
}

bool SetupDialog::answer_one(const Question& question, Answers& answers, const SetupFacts& facts) {
  const std::string key(question.key);
  Suggestion usual = question.suggest(answers, facts);
  if (const auto before = answers.find(key);
      before != answers.end() && question.take(before->second, answers, facts).complaint.empty())
    usual = {before->second, "as answered before"};
  fmt::print("\n");
  say(question.text);
  say(fmt::format("  Enter: {}, {}", usual.answer, usual.why), 2);
  const std::string expected = question.take("?", answers, facts).complaint;
  const std::string help = fmt::format(
      "{}{}Enter accepts {}; back returns to the previous question; quit leaves, and the next call continues "
      "here. docs/printer-setup.md explains the parts.",
      expected, expected.empty() ? "" : " ", usual.answer);
  while (true) {
    const std::string typed = ask(key + ":", help);
    if (typed == "back") return false;
    const TakenAnswer taken = question.take(typed.empty() ? usual.answer : typed, answers, facts);
    if (taken.complaint.empty()) {
      answers[key] = taken.answer;
      return true;
    }
    say(taken.complaint);
  }
}

}  // namespace contourd::ctl
