#include "autodiff/error.h"

#include <stdio.h>
#include <stdlib.h>

const char *ad_status_text(ad_status status)
{
    static const char *const text[AD_STATUS_COUNT] = {
#define AD_STATUS_TEXT(name, words) [name] = words,
        AD_STATUS_LIST(AD_STATUS_TEXT)
#undef AD_STATUS_TEXT
    };
    return (unsigned)status < AD_STATUS_COUNT ? text[status] : "unknown status";
}

int ad_number_text(double number, char text[32])
{
    int length = 0;
    for (int digits = 15; digits <= 17; digits++) {
        length = snprintf(text, 32, "%.*g", digits, number);
        if (strtod(text, NULL) == number) {
            break;
        }
    }
    return length;
}

void ad_one_line(char *text)
{
    for (; *text; text++) {
        *text = (unsigned char)*text < ' ' || *text == 0x7f ? '?' : *text;
    }
}

ad_status ad_fail_list(ad_error *error, ad_status status, const char *format, va_list arguments)
{
    if (error) {
        vsnprintf(error->message, sizeof error->message, format, arguments);
        ad_one_line(error->message);
        error->status = status;
    }
    return status;
}

ad_status ad_fail(ad_error *error, ad_status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    ad_fail_list(error, status, format, arguments);
    va_end(arguments);
    return status;
}
