// The protocol of a side (sides.py) for programs in C++: `calls` fits for every line that comes.
#pragma once
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <string>

// What all sides are given: eye, target, field of view in degrees, near, far, light, the scene's box: 18 numbers and a count.
struct Given {
    double eye[3], target[3], fov_deg, near, far, light[3], least[3], most[3];
    int calls;
};

inline Given given(int count, char** texts) {
    if (count != 20) {
        std::fprintf(stderr, "expected 18 numbers and a count of calls, got %d arguments\n", count - 1);
        std::exit(2);
    }
    Given g;
    double* to = g.eye;
    for (int i = 0; i < 18; ++i) to[i] = std::atof(texts[1 + i]);
    g.calls = std::atoi(texts[19]);
    return g;
}

// Prints the program's name, and a time for every line of standard input.
template <class Fit> void serve(const char* about, int calls, Fit fit) {
    std::printf("{\"about\": \"%s\", \"check\": {}}\n", about);
    std::fflush(stdout);
    std::string line;
    while (std::getline(std::cin, line)) {
        timespec w0, w1, c0, c1;
        clock_gettime(CLOCK_MONOTONIC, &w0);
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &c0);
        for (int i = 0; i < calls; ++i) fit();
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &c1);
        clock_gettime(CLOCK_MONOTONIC, &w1);
        auto seconds = [](timespec a, timespec b) { return double(b.tv_sec - a.tv_sec) + 1e-9 * double(b.tv_nsec - a.tv_nsec); };
        std::printf("{\"wall\": %.9g, \"cpu\": %.9g}\n", seconds(w0, w1), seconds(c0, c1));
        std::fflush(stdout);
    }
}
