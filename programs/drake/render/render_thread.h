// Queue of render requests and the thread that owns the device. Requests are answered in order of arrival.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "programs/drake/http/server.h"
#include "programs/drake/render/image_renderer.h"

namespace fire3dv::drake {

class RenderThread {
 public:
  // on_failure: called on the thread, once, when the device is lost and nothing can be rendered any more.
  RenderThread(ImageRenderer& renderer, std::function<void(const std::string&)> on_failure);
  ~RenderThread();

  void push(HttpRequest&& request, HttpServer::Answer answer);  // from any thread
  // Ends the thread after its current image, without answers to others. False: it still renders after this
  // time.
  bool stop(std::chrono::milliseconds patience);

 private:
  struct Job {
    HttpRequest request;
    HttpServer::Answer answer;
  };
  void run();
  HttpAnswer answer_to(const HttpRequest& request);

  ImageRenderer& renderer_;
  const std::function<void(const std::string&)> on_failure_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::deque<Job> jobs_;
  bool stopping_ = false, ended_ = false;
  std::thread thread_;  // last: it uses all others
};

}  // namespace fire3dv::drake
