#include "daemon/queue_order.hpp"

#include <algorithm>
#include <set>

namespace contourd {

void QueueOrder::move(const std::string& file, const std::optional<std::string>& next,
                      const std::vector<std::string_view>& first) {
  const std::set<std::string, std::less<>> named(names_.begin(), names_.end());
  for (const std::string_view each : first)
    if (!named.contains(each)) names_.emplace_back(each);
  std::erase(names_, file);
  names_.insert(next ? std::ranges::find(names_, *next) : names_.end(), file);
  keep_now();
}

void QueueOrder::remove(const std::string& file) {
  if (std::erase(names_, file) > 0) keep_now();
}

void QueueOrder::keep_now() {
  if (keeping_ || names_ == kept_) return;
  keeping_ = true;
  keep_(names_, [this, names = names_](const std::string& trouble) {
    keeping_ = false;
    // What was not taken is tried with the next change: it counts when contourd starts again.
    kept_ = names;
    if (trouble_ != trouble && !trouble.empty()) failed_(trouble);
    trouble_ = trouble;
    keep_now();
  });
}

}  // namespace contourd
