// SPDX-License-Identifier: Apache-2.0
#include "exec/team.hpp"

#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <mutex>
#include <new>
#include <system_error>

#include "exec/threads.hpp"

namespace meltsim {
inline namespace v0 {
namespace core {
namespace {

/// How long a waiting thread spins before it sleeps: longer than the gap between two loops of a sub-step, and a
/// hundredth of a time slice, which another program may need.
constexpr auto patience = std::chrono::microseconds(50);

// Team::Shared::state: helpers inside a job, members it may have, whether it may still be entered, its number.
using State = std::uint64_t;
constexpr int count_bits = 12;
constexpr State one_inside = 1;
constexpr State one_member = State{1} << count_bits;
constexpr State open_bit = State{1} << (2 * count_bits);
constexpr State one_job = open_bit << 1;
static_assert(Team::max_members < (1 << count_bits));

constexpr State inside(State s) { return s & (one_member - 1); }
constexpr int members_of(State s) { return static_cast<int>((s >> count_bits) & (one_member - 1)); }
constexpr State job_of(State s) { return s / one_job; }

/// done() within `patience`; not tried where threads outnumber processors, since the thread that is waited for needs this processor.
template <class Done>
bool soon(bool patient, const Done& done) {
  if (done()) return true;
  if (!patient) return false;
  const auto until = std::chrono::steady_clock::now() + patience;
  do {
    for (int k = 0; k < 16; ++k) {
      if (done()) return true;
#if defined(__x86_64__) || defined(__i386__)
      __builtin_ia32_pause();
#endif
    }
  } while (std::chrono::steady_clock::now() < until);
  return done();
}

/// While it lives, threads that are made take no signals: those are the host's.
class WithoutSignals {
 public:
  WithoutSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~WithoutSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  WithoutSignals(const WithoutSignals&) = delete;
  WithoutSignals& operator=(const WithoutSignals&) = delete;

 private:
  sigset_t before_;
};

}  // namespace

struct Team::Shared {
  std::atomic<State> state{0};
  Work work = nullptr;  ///< written while no job is open and no thread is inside
  const void* data = nullptr;
  std::atomic<bool> ending{false};
  std::atomic<int> asleep{0};  ///< helpers that need a call
  std::atomic<bool> caller_asleep{false};
  std::mutex mutex;
  std::condition_variable called, left;

  void call() {
    { const std::lock_guard<std::mutex> lock(mutex); }  // no thread is between spinning and sleeping
    called.notify_all();
  }
};

Team& Team::of_this_thread() {
  static thread_local Team team;
  return team;
}

void Team::run(int members, Work work, const void* data) {
  members = std::min(members, max_members);
  if (members > 1 && !running_) grow(members);
  members = std::min(members, static_cast<int>(helpers_.size()) + 1);
  if (members <= 1 || running_) return work(data, 0);

  Shared& s = *shared_;
  s.work = work;
  s.data = data;
  // Sequentially consistent, as are the helpers' own: either this sees who sleeps, or they see the job.
  s.state.store((job_of(s.state.load(std::memory_order_relaxed)) + 1) * one_job + open_bit +
                static_cast<State>(members) * one_member);
  if (s.asleep.load() > 0) s.call();
  running_ = true;
  work(data, 0);
  running_ = false;
  s.state.fetch_and(~open_bit);
  const auto all_left = [&s] { return inside(s.state.load()) == 0; };
  if (soon(members <= processors(), all_left)) return;
  std::unique_lock<std::mutex> lock(s.mutex);
  s.caller_asleep.store(true);
  s.left.wait(lock, all_left);
  s.caller_asleep.store(false);
}

void Team::help(Shared& s, int member) {
  for (State seen = 0;;) {
    const auto news = [&s, &seen] { return job_of(s.state.load()) != seen || s.ending.load(); };
    const int expected = members_of(s.state.load());
    if (!soon(member < expected && expected <= processors(), news)) {
      std::unique_lock<std::mutex> lock(s.mutex);
      s.asleep.fetch_add(1);
      s.called.wait(lock, news);
      s.asleep.fetch_sub(1);
    }
    if (s.ending.load()) return;
    State now = s.state.load();
    seen = job_of(now);
    bool entered = false;
    while (!entered && job_of(now) == seen && (now & open_bit) != 0 && member < members_of(now))
      entered = s.state.compare_exchange_weak(now, now + one_inside);
    if (!entered) continue;
    s.work(s.data, member);
    const State before = s.state.fetch_sub(one_inside);
    if ((before & open_bit) == 0 && inside(before) == 1 && s.caller_asleep.load()) {
      { const std::lock_guard<std::mutex> lock(s.mutex); }
      s.left.notify_one();
    }
  }
}

void Team::grow(int members) {
  if (process_ != getpid()) leave_behind();
  if (static_cast<int>(helpers_.size()) + 1 >= members || refused_) return;
  const WithoutSignals quiet;
  try {
    if (shared_ == nullptr) shared_ = new Shared;
    helpers_.reserve(static_cast<std::size_t>(members));
    while (static_cast<int>(helpers_.size()) + 1 < members) {
      const int member = static_cast<int>(helpers_.size()) + 1;
      helpers_.emplace_back([shared = shared_, member] { help(*shared, member); });
    }
  } catch (const std::system_error&) {
    refused_ = true;
  } catch (const std::bad_alloc&) {
    refused_ = true;
  }
}

/// After a fork: the helpers are threads of another process, and what they share may have been copied while one of them
/// held it.
void Team::leave_behind() {
  for (std::thread& t : helpers_) t.detach();
  helpers_.clear();
  shared_ = nullptr;
  refused_ = false;
  process_ = getpid();
}

Team::~Team() {
  if (process_ != getpid()) leave_behind();
  if (shared_ == nullptr) return;
  shared_->ending.store(true);
  shared_->call();
  for (std::thread& t : helpers_) t.join();
  delete shared_;
}

}  // namespace core
}  // namespace v0
}  // namespace meltsim
