// Time limit of a step of a connection: calls back once, unless it is set again, cancelled, or the connection
// has ended.
#pragma once

#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <memory>
#include <utility>

namespace fire3dv::transport::http {

class Deadline {
 public:
  explicit Deadline(const boost::asio::steady_timer::executor_type& executor) : timer_(executor) {}

  // Owner: has this deadline. on_over(owner) is called on the executor's thread.
  template <typename Owner, typename OnOver>
  void set(std::chrono::steady_clock::duration time, std::weak_ptr<Owner> owner, OnOver on_over) {
    timer_.expires_after(time);
    timer_.async_wait(
        [this, weak = std::move(owner), on_over = std::move(on_over)](boost::system::error_code error) {
          const std::shared_ptr<Owner> self = weak.lock();
          // A handler that was queued before the deadline was set again is out of date.
          if (error || !self || timer_.expiry() > std::chrono::steady_clock::now()) return;
          on_over(*self);
        });
  }
  void cancel() { timer_.cancel(); }

 private:
  boost::asio::steady_timer timer_;
};

}  // namespace fire3dv::transport::http
