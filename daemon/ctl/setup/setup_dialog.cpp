#include "daemon/ctl/setup/setup_dialog.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>

#include "daemon/ctl/terminal/terminal.hpp"
#include "daemon/ctl/terminal/text_columns.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

constexpr std::size_t kLongestLine = 1000;
constexpr std::size_t kMostColumns = 100;  // longer lines are hard to read
constexpr std::size_t kNoQuestion = static_cast<std::size_t>(-1);

std::size_t columns() {
  return std::clamp(static_cast<std::size_t>(std::max(terminal_columns(), 0)), std::size_t{20}, kMostColumns);
}

std::string trimmed(const std::string& text) {
  const std::size_t from = text.find_first_not_of(" \t\r"), to = text.find_last_not_of(" \t\r");
  return from == std::string::npos ? "" : text.substr(from, to - from + 1);
}

}  // namespace

// --- LineInput

bool LineInput::read_more() {
  std::array<char, 4096> bytes{};
  ssize_t count = 0;
  do
    count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
  while (count < 0 && errno == EINTR);
  if (count <= 0) ended_ = true;
  if (count > 0) read_.append(bytes.data(), static_cast<std::size_t>(count));
  return !ended_;
}

std::optional<std::string> LineInput::line() {
  std::size_t end = read_.find('\n');
  while (end == std::string::npos && read_more()) {
    end = read_.find('\n');
    if (end == std::string::npos && read_.size() > kLongestLine) read_.resize(kLongestLine);
  }
  if (end == std::string::npos) return std::nullopt;
  std::string text = read_.substr(0, std::min(end, kLongestLine));
  read_.erase(0, end + 1);
  return text;
}

bool LineInput::wait(std::chrono::milliseconds time) {
  if (ended_ || read_.find('\n') != std::string::npos) return true;
  pollfd input{STDIN_FILENO, POLLIN, 0};
  return ::poll(&input, 1, static_cast<int>(time.count())) > 0;
}

// --- SetupDialog

void SetupDialog::say(std::string_view text, std::size_t indent) const {
  const std::string margin(indent, ' ');
  bool first = true;
  const std::size_t width = columns();
  for (const std::string& line : wrapped(printable(text), width - std::min(indent, width / 2))) {
    fmt::print("{}{}\n", first ? "" : margin, line);
    first = false;
  }
  std::fflush(stdout);
}

std::string SetupDialog::ask(std::string_view prompt) {
  fmt::print("{} ", printable(prompt));
  std::fflush(stdout);
  const std::optional<std::string> line = input_.line();
  if (!line) throw SetupLeft();
  if (::isatty(STDIN_FILENO) == 0) fmt::print("\n");
  std::string answer = trimmed(*line);
  if (answer == "quit") throw SetupLeft();
  return answer;
}

std::string SetupDialog::ask_for_word(std::string_view prompt, const std::vector<std::string>& words) {
  while (true) {
    const std::string answer = ask(prompt);
    if (answer.empty()) return words.front();
    const auto fits = [&](const std::string& word) { return word.starts_with(answer); };
    if (std::ranges::count_if(words, fits) == 1) return *std::ranges::find_if(words, fits);
    std::string choices;
    for (const std::string& word : words)
      choices += (choices.empty() ? "" : ", ") + word;
    say("Expected one of: " + choices + ".");
  }
}

std::optional<double> SetupDialog::ask_for_number(std::string_view prompt, double least, double most) {
  while (true) {
    const std::string answer = ask(prompt);
    if (answer.empty()) return std::nullopt;
    const std::optional<double> number = number_of(answer);
    if (number && *number >= least && *number <= most) return number;
    say(fmt::format("Expected a number from {:g} to {:g}.", least, most));
  }
}

bool SetupDialog::typed_within(std::chrono::milliseconds time) {
  if (!input_.wait(time)) return false;
  const std::optional<std::string> line = input_.line();
  if (!line || trimmed(*line) == "quit") throw SetupLeft();
  return true;
}

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
  // Earlier answers are not compared with this computer's devices: a device need not be plugged in now, and
  // the answers may be for another computer.
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
  while (true) {
    const std::string typed = ask(key + ":");
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
